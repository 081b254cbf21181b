# find failing leaves quickly: only check leaves with small budget
import sys
sys.argv=['write','uc3','7.5,8,7','0,1,2','1']
src=open('wip/write.py').read().split("def check_all")[0]
src=src.replace("rec=Recorder(red,setting,s,known)","rec=Recorder(red,setting,s,known)")
exec(src)
import random, certificates.searches as cs, certificates.cells as C
from certificates.geometry import Turned
from certificates.polynomials import between, centre, lowest, size, slopes, number, dot, constant
from certificates import guess
cs.PIECES=400
s=s2
import pickle
rng=random.Random(1); lv=rng.sample(s.leaves,300)
for l in lv:
    try: s.check(l)
    except Exception as e:
        print(l.cell.bounds,l.cell.side,l.cell.chart,l.node,l.data)
        u=[between(rational(a),rational(b),k) for k,(a,b) in enumerate(l.cell.bounds[:3])]
        T=Turned(s.platform,l.cell.chart,u)
        for d in (1,2):
            x=C.on_branch(T,l.cell.side,d); print(d, x is None)
            y=C.near_branch(T,l.cell.side,d); print('near',y is None)
            if x is None: continue
            P_=C.Place(T,x); w=T.wrenches(x)
            rows=[[number(centre(v)) for v in q] for q in w]
            print('x sl',[[f'{number(v):.2g}' for v in slopes(q,range(7))] for q in x], 'cols',P_.columns)
            print('y.w centre',[guess.inner(l.data,r) for r in rows], [sum(abs(a*b) for a,b in zip(l.data,r)) for r in rows])
        # at the middle
        for f in (0.5,0.0,1.0):
            bb=[a+(b-a)*f for a,b in l.cell.bounds[:3]]
            T=Turned(s.platform,l.cell.chart,[constant(rational(v)) for v in bb])
            x=C.on_branch(T,l.cell.side,1)
            if x is None: print('none at',f); continue
            w=T.wrenches(x); rows=[[number(centre(v)) for v in q] for q in w]
            print('mid',[guess.inner(l.data,r) for r in rows])
            nr=[[v/guess.inner(r,r)**.5 for v in r] for r in rows]
            yy=guess.least_norm(nr,[[1.0]*4]); print('ls y',yy, [guess.inner(yy[0],r) for r in rows])
            print('cond', P_.unbalanced(list(l.data)))

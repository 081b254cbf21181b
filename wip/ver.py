import sys; sys.path.insert(0,'/work/main')
import time, random
from fractions import Fraction as Fr
from collections import Counter
import numpy as np
from cdpr_interval import load_robot
from solvers.problem import Problem
from solvers.platform_model import platform_size, triples_by_spread
from certificates.polynomials import *
from certificates.geometry import *
from certificates import cells as cl, guess
name,ls=sys.argv[1],sys.argv[2].split(',')
r=load_robot(name); n=len(ls); pr=Problem(r,())
a=np.array([[float(x) for x in c.frame_anchor] for c in r.cables]); b=np.array([[float(x) for x in v] for v in pr.anchors_from_centre])
order=[int(x) for x in triples_by_spread(a,b,n)[0]]; sz=platform_size(b)
A=[r.cables[i].frame_anchor for i in order]; B=[pr.anchors_from_centre[i] for i in order]
cst=lambda v:[constant(rational(x)) for x in v]
pf=Platform([cst(v) for v in A],[cst(v) for v in B],[constant(rational(Fr(ls[i])**2)) for i in order],cst(pr.load),n,rational(sz))
D=np.load(f'/tmp/p/cert/{name}.npy'); rng=random.Random(1)
def check(kind,s,c,y,depth=0):
    u=[between(rational(float(c[2*k])),rational(float(c[2*k+1])),k) for k in range(3)]
    T=Turned(pf,int(c[6] if kind==0 else c[12]),u)
    ok=True
    if kind==0:
        for br in ((1,-1) if c[7]==0 else (int(c[7]),)):
            if s==16:
                ok=ok and cl.no_position(T); continue
            for deg in DEG:
                x=cl.on_branch(T,br,deg)
                if x is None: ok=False; why['nobranch',deg]+=1; continue
                P=cl.Place(T,x)
                if s==17: ok=P.no_length()
                if s==19: ok=P.unbalanced([float(v) for v in y])
                if ok: break
                why['test',deg]+=1
            if not ok: ok=cl.no_position(T)
            if not ok: break
    else:
        x=[between(rational(float(c[6+2*k])),rational(float(c[7+2*k])),3+k) for k in range(3)]
        P=cl.Place(T,x)
        if s==17: ok=P.no_length()
        if s==19: ok=P.unbalanced([float(v) for v in y])
    if ok: return 1
    if depth>=5: return None
    nv=3 if kind==0 else 6
    w=[(c[2*k+1]-c[2*k])*(1 if k<3 else .4/sz) for k in range(nv)]; k=int(np.argmax(w))
    m=0.5*(c[2*k]+c[2*k+1]); tot=0
    for h in (0,1):
        d=c.copy(); d[2*k+1-h]=m
        q=check(kind,s,d,y,depth+1)
        if q is None: return None
        tot+=q
    return tot
cnt=Counter(); t=Counter(); why=Counter(); DEG=eval(sys.argv[4])
for kind in (0,1):
    for s in (16,17,19):
        rows=D[(D[:,0]==kind)&(D[:,1]==s)]
        if len(rows)==0: continue
        K=min(int(sys.argv[3]),len(rows)); t0=time.time()
        for row in rng.sample(list(rows),K):
            q=check(kind,s,row[2:16].copy(),row[16:22])
            cnt[kind,s,q]+=1
        t[kind,s]=round((time.time()-t0)/K*1e3,2)
for k in sorted(cnt,key=str): print(k,cnt[k])
print(t,why)

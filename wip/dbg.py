import sys
sys.argv=['ver','uc3','7.5,8,7','1','[2]']
exec(open('wip/ver.py').read())
rows=D[(D[:,0]==0)&(D[:,1]==19)]
rng=random.Random(1); bad=0
for row in rng.sample(list(rows),200):
    c=row[2:16]; y=row[16:22]
    if check(0,19,c.copy(),y,4) is not None: continue
    bad+=1
    if bad>8: break
    u=[between(rational(float(c[2*k])),rational(float(c[2*k+1])),k) for k in range(3)]
    T=Turned(pf,int(c[6]),u); x=cl.on_branch(T,int(c[7]),2)
    print('cell',[round(c[2*k+1]-c[2*k],4) for k in range(3)], 'tau,rest', [ [f'{number(v):.2g}' for v in slopes(z,range(7))] for z in x][0:3] if x else None)
    if x is None: continue
    P=cl.Place(T,x); wr=T.wrenches(x); fx=[constant(rational(float(v))) for v in y]
    for w in wr:
        f=dot(fx,w); print('  const',[ (f'{number(centre(g)):.3g}',f'{number(size(g)-abs(centre(g))):.3g}') for g in [f,*P.freed(f)]])
    rr=[[number(centre(v)) for v in w] for w in wr]
    fr=[P.freed(dot(fx,w))[0] for w in wr]
    ch=guess.least_norm(rr,[[-number(v) for v in col] for col in zip(*(slopes(f,cl.POSE) for f in fr))])
    mv=[v+total([SYMBOL[k]*rational(sl[i]) for k,sl in zip(cl.POSE,ch)]) for i,v in enumerate(fx)]
    for w in wr:
        f=dot(mv,w); print('  move',[ (f'{number(centre(g)):.3g}',f'{number(size(g)-abs(centre(g))):.3g}') for g in [f,*P.freed(f)]])
